"""The program: command line, window, headless rendering. Wires core and widgets together."""
