"""Where model and measurement disagree: balances in weak form, nuisances, gaps."""
