"""The reference: a page a kind of element, written from the expressions that are compiled."""
