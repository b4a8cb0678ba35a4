"""Many flights that answer one question each."""
