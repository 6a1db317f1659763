#pragma once

#include "common/descriptor/family.hpp"
#include "tests/bench/descriptors/figures.hpp"
#include "tests/mine/scenario.hpp"

namespace headframe::bench {

/// Levelling and extraction of every scan, one after another on this thread.
ExtractTimes time_extraction(const DescriptorFamily& family, const mine::Recording& recording);

/// The 20 nearest of 1701 keyframes among 2840, through the server's exact index: medians of several runs. used:
/// numbers of q that are not zero, the first ones.
QueryTimes time_query_all(std::size_t q_size, std::size_t used);

}  // namespace headframe::bench
