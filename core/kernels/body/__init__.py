"""Where rays end at the car's own body, triangle by triangle."""
