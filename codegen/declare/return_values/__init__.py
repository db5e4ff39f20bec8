"""What methods of elements and bodies return, checked by kind: own ones may return anything.

Each function calls one method, or reads one property, and returns a value of one kind. An
exception, and a value of another kind, is a `ModelError` that names the element, the method and the
value.
"""
