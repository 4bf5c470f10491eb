"""What a person takes along: tables and programs."""
