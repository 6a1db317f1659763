#pragma once

namespace headframe {

/// For a connected TCP socket whose link loses packets and goes dark: what was lost is sent again every second at
/// the latest, for a minute and a half, not after ever longer waits, so that the connection lives on as soon as the
/// link is back. Linux before 6.15 keeps its waits short for six times only. Where the
/// kernel refuses, the link works as TCP does.
void expect_losses(int socket);

}  // namespace headframe
