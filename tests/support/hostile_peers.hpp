#pragma once
// Peers that mean harm, over TLS: each does one thing and says what the server answered until it closed.

#include <functional>
#include <string>
#include <vector>

#include "common/endpoint.hpp"

namespace headframe::test {

struct HostileTarget {
  Endpoint server;
  std::string victim;      // a robot that is enrolled, whose credential the peers do not have
  std::string accomplice;  // a robot that is enrolled,
  std::string token;       // and its token
  std::string used_code;   // an enrolment code that the accomplice has used
  Endpoint http = {};      // of the operator
};

/// Enrols the accomplice with the code of an open enrolment, and connects once.
void enrol_accomplice(const HostileTarget& target);

struct HostilePeer {
  const char* name;
  const char* answer;  // words of what it is told; "": it is closed without a word
  std::function<std::string(const HostileTarget&)> attack;
};

/// All but the flood end within the server's limits.hello_s.
const std::vector<HostilePeer>& hostile_peers();

/// Something done once, to be done again and again; ends within some seconds, whatever the server does.
struct HostileAct {
  const char* name;
  std::function<void(const HostileTarget&)> act;
};

/// What a robot that was let in may tell whose odometry or lidar is broken, by malice or not.
const std::vector<HostileAct>& hostile_drives();

/// What else a robot that was let in may do.
const std::vector<HostileAct>& hostile_robots();

/// What may be done at the operator's port without the token.
const std::vector<HostileAct>& hostile_clients();

}  // namespace headframe::test
