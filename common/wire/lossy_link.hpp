#pragma once

namespace headframe {

/// Prepares a connected TCP socket for a link that loses packets and has gaps in coverage: lost data is retransmitted
/// at least every second for a minute and a half, instead of after ever longer waits, so that the connection continues
/// as soon as the link is back. Linux before 6.15 keeps the waits short only six times. If the kernel refuses, TCP's
/// usual waits apply.
void expect_losses(int socket);

}  // namespace headframe
