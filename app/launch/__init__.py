"""From the first line of the program to the window, and out again."""
