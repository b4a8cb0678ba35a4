"""Where the UAV is to be and how it is to be turned."""
