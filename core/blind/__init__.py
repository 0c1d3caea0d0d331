"""Near-field blind zones: the ground around the car on which objects of a height are unseen."""
