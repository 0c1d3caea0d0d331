"""Prepare the process before any package is loaded: system libraries, display, Ctrl-C, the user's folders."""
