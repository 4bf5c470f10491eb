"""The page: sidebar, portrait, player, dialogs."""
