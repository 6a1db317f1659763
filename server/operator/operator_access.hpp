#pragma once

#include <boost/asio/ssl/context.hpp>
#include <filesystem>
#include <string>

#include "server/security/operator_registry.hpp"
#include "server/station/robot_admin.hpp"

namespace headframe {

struct OperatorAccess {
  std::string token = {};                    // required by every request that is not public; empty: none is required
  RobotAdmin* robots = nullptr;              // must outlive the API; null: robots connect without enrolling
  std::filesystem::path log = {};            // file of the event log; empty: it is kept only in memory
  std::filesystem::path notes = {};          // file of the notes; empty: they are kept only in memory
  OperatorRegistry* people = nullptr;        // named operators; must outlive the API; null: there are none
  boost::asio::ssl::context* tls = nullptr;  // HTTPS; must outlive the API; null: plain HTTP
};

}  // namespace headframe
