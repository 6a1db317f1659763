// headframe: the operator's command. Talks to headframe-server over HTTP.

#include <iostream>
#include <nlohmann/json.hpp>

#include "server/cli/command_line.hpp"
#include "server/cli/table.hpp"
#include "server/cli/token.hpp"
#include "server/cli/trust.hpp"

namespace {

using headframe::Commands;
using headframe::Options;

int fault(const headframe::Error& error) {
  std::cerr << "headframe: " << headframe::printable(error.message) << '\n';
  return error.code == headframe::ErrorCode::invalid_argument ? headframe::exit_usage : headframe::exit_failed;
}

/// Of a command that has commands of its own, and of the program itself.
headframe::Error nothing_said(const CLI::App& app) {
  const auto chosen = app.get_subcommands();
  const CLI::App& at = chosen.empty() ? app : *chosen.front();
  std::string there;
  for (const CLI::App* sub : at.get_subcommands([](const CLI::App*) { return true; }))
    there += (there.empty() ? "" : ", ") + sub->get_name();
  const std::string name = chosen.empty() ? "headframe" : "headframe " + at.get_name();
  return {headframe::ErrorCode::invalid_argument,
          "say what to do: " + name + " has " + there + "; " + name + " --help tells more"};
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("The operator's command of headframe: what the base station knows, and the merged map.", "headframe");
  app.add_option("--http", options.http,
                 "Where headframe-server answers operators. Without https:// or http://: HTTPS, but on the loopback")
      ->capture_default_str()
      ->envname("HEADFRAME_HTTP")
      ->type_name("[https://]HOST:PORT");
  app.add_option("--fingerprint", options.fingerprint,
                 "Of the server's certificate, as headframe-server prints it: HTTPS with that server alone")
      ->envname("HEADFRAME_FINGERPRINT")
      ->type_name("HEX");
  app.add_option("--ca", options.authorities,
                 "PEM file of who vouches for the server's certificate; default: whom this machine trusts")
      ->envname("HEADFRAME_CA")
      ->type_name("FILE");
  app.add_option("--token-file", options.token_file,
                 "The server's DATA/operator.token. Without it: $HEADFRAME_TOKEN, or headframe-data/operator.token")
      ->envname("HEADFRAME_TOKEN_FILE")
      ->type_name("FILE");
  app.add_flag("--json", options.json, "Print JSON");
  app.set_version_flag("--version", "headframe " HEADFRAME_VERSION);
  app.require_subcommand(0, 1);  // of 1, a misspelt one would be called a missing one
  app.fallthrough();
  for (const auto add : {headframe::add_look_commands, headframe::add_pair_commands, headframe::add_export_commands,
                         headframe::add_session_commands, headframe::add_store_commands, headframe::add_robot_commands,
                         headframe::add_site_commands, headframe::add_operator_commands})
    add(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << "headframe: " << headframe::printable(error.what()) << "; headframe --help lists what there is\n";
    return headframe::exit_usage;
  }
  if (!options.command) return fault(nothing_said(app));
  auto endpoint = headframe::parse_http_endpoint(options.http);
  if (!endpoint) return fault({endpoint.error().code, "--http: " + endpoint.error().message});
  auto token = headframe::find_token(options.token_file);
  if (!token) return fault(token.error());
  endpoint->token = *token;
  auto trust = headframe::find_trust(options.fingerprint, options.authorities, options.token_file);
  if (!trust) return fault(trust.error());
  endpoint->trust = *trust;
  Commands commands(*endpoint, options.json);
  const auto code = options.command(commands);
  return code ? *code : fault(code.error());
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const nlohmann::json::exception&) {
    return fault(
        {headframe::ErrorCode::bad_input, "the answer is not the JSON of headframe-server; is it another one?"});
  } catch (const std::exception& exception) {
    return fault({headframe::ErrorCode::internal, exception.what()});
  }
}
