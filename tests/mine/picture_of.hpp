#pragma once
// Recordings as layers of a picture.

#include "server/picture/top_view.hpp"
#include "tests/mine/scenario.hpp"

namespace headframe::mine {

/// The recording's map and way in its session's frame, as the robot believes it (drift included); thinned for drawing.
picture::Layer believed_layer(const Recording& recording, const picture::Colour& colour);

/// All recordings where they truly were.
picture::TopView true_picture(const std::string& title, const std::vector<Recording>& recordings);

}  // namespace headframe::mine
