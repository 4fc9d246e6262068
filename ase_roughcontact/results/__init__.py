"""Results of a relaxed step: columns, errors and limits of the model."""
