#pragma once

#include <boost/asio/ssl/context.hpp>
#include <filesystem>
#include <string>

#include "server/security/operator_registry.hpp"
#include "server/station/robot_admin.hpp"

namespace headframe {

struct OperatorAccess {
  std::string token = {};                    // what every request but the public ones has to show; empty: none
  RobotAdmin* robots = nullptr;              // must outlive the API; null: robots come in without enrolling
  std::filesystem::path log = {};            // where what happens is written down; empty: kept in memory alone
  std::filesystem::path notes = {};          // where notes are kept; empty: in memory alone
  OperatorRegistry* people = nullptr;        // named operators; must outlive the API; null: there are none
  boost::asio::ssl::context* tls = nullptr;  // HTTPS; must outlive the API; null: plain HTTP
};

}  // namespace headframe
