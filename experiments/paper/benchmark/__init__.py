"""The open benchmark: its frozen tasks, its scores, entries and their verification."""
