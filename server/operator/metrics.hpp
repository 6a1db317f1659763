#pragma once

#include <string>

#include "server/station/station.hpp"

namespace headframe {

/// GET /metrics: Prometheus text (exposition format 0.0.4). Totals end in _total; base units are seconds and bytes.
/// Pure.
std::string metrics_text(const std::vector<SessionRow>& sessions, const AtlasView& view, const Pending& pending,
                         const Workload& work, const LinkHealth& links, const std::vector<Survey>& surveys,
                         double uptime_s);

}  // namespace headframe
