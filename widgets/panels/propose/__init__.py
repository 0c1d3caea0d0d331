"""Panel of proposed rigs: options, charts, proposals and the checks of their gain."""
