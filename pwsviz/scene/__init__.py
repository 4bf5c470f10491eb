"""What a person has chosen: its checks, its history, its link."""
