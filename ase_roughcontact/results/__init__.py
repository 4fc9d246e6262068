"""What is known of a relaxed step: columns, errors and limits of the model."""
