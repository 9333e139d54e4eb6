"""One module per table: what a workflow rule and a command of the same name do."""
