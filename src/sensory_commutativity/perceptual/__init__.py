"""How different two pictures look: distances of features of a network that was trained to see."""
