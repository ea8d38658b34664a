"""Evidence of changes of a model: products of residuals and columns, likelihood, and fits."""
