"""ROS topics and bags into headframe, and what the base station tells back into ROS."""
