"""Resumable pieces of work, on local processes or on a Dask cluster."""
