"""The crawl over obstacles."""
