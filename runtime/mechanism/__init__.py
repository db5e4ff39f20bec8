"""A loaded mechanism as data: description, kernels, parameters, companion modules."""
