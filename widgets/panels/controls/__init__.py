"""Building blocks of panels: style, icons, tables, menus, messages."""
