"""What a rig gets onto road users: points, cells and pixels, behind traffic."""
