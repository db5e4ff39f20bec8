"""The ground floor: kernel ABI, function table, workspace, compiled-function decorators."""
