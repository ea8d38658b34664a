"""Records of conformity: measured quantities against limits."""
