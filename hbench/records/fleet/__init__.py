"""Fleet of campaigns: their numbers, and the statistics over all of them."""
