"""Pictures of mechanisms: shapes of elements, outlines of bodies, figures."""
