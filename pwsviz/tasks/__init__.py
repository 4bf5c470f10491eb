"""Work that is done beside the page: the latest wins, and what is no longer wanted is cancelled."""
