"""Prepare the process before Qt is loaded: Ctrl-C, and the folders of the user."""
