"""Rays on road users: what each ray meets first, counted, painted or swept."""
