"""A run looked at afterwards: figures, pictures, a page."""
