"""The reference: a page for each kind of element, written from the compiled expressions."""
