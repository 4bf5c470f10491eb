"""What can be exported: tables, pictures and programs."""
