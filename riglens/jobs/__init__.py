"""Jobs of commands and Python functions: options and a monitor in, results out."""
