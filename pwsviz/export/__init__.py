"""What is exported: tables and programs."""
