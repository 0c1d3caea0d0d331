"""Tables of figures: one model and one view for all of them."""
