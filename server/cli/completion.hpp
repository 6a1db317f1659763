#pragma once

#include <CLI/App.hpp>
#include <array>
#include <string>

namespace headframe {

inline constexpr std::array completed_shells{"bash", "zsh", "fish"};

/// A script that completes the subcommands and options of `app` in one of completed_shells, and files elsewhere.
std::string completion(const CLI::App& app, const std::string& shell);

}  // namespace headframe
