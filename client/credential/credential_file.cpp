#include "client/credential/credential_file.hpp"

#include <map>
#include <sstream>

#include "common/security/enrolment.hpp"
#include "common/security/private_file.hpp"
#include "common/security/secret.hpp"

namespace headframe {
namespace {

// The file: a first line that says what it is, then "name value" lines.
constexpr std::string_view title = "headframe credential 1";

std::map<std::string, std::string> lines_of(const std::string& content) {
  std::map<std::string, std::string> lines;
  std::istringstream in(content);
  for (std::string line; std::getline(in, line);) {
    const auto space = line.find(' ');
    if (line != title && space != std::string::npos) lines[line.substr(0, space)] = line.substr(space + 1);
  }
  return lines;
}

}  // namespace

Result<CredentialFile> CredentialFile::open(const std::filesystem::path& path, const std::string& robot,
                                            const std::string& enrolment) {
  CredentialFile file;
  file.path_ = path;
  file.robot_ = robot;
  auto content = read_private_file(path);
  const bool is_new = !content && content.error().code == ErrorCode::not_found;
  if (!content && !is_new) return tl::unexpected(content.error());
  if (is_new && enrolment.empty())
    return failure(ErrorCode::invalid_argument, "robot " + robot + " has no credential in " + path.string() +
                                                    ": the operator runs `headframe robot add " + robot +
                                                    "`, and --enrol takes what it prints");
  if (!is_new) {
    auto lines = lines_of(*content);
    const auto fingerprint = parse_fingerprint(lines["server"]);
    const auto token = from_hex(lines["token"], token_bytes);
    const auto code = lines["code"].empty() ? Result<std::string>("") : from_hex(lines["code"], code_bytes);
    if (content->rfind(title, 0) != 0 || !fingerprint || !token || !code)
      return failure(ErrorCode::bad_input, path.string() + " is no credential; remove it and enrol the robot anew");
    if (lines["robot"] != robot)
      return failure(ErrorCode::refused, path.string() + " is robot " + lines["robot"] + "'s, not " + robot + "'s");
    file.credential_ = {*fingerprint, *token, *code};
    file.enrolled_with_ = from_hex(lines["enrolled-with"], 32).value_or("");
  }
  if (enrolment.empty()) return file;
  const auto wanted = parse_enrolment(enrolment);
  if (!wanted) return tl::unexpected(wanted.error());
  if (wanted->code == file.credential_.code || sha256(wanted->code) == file.enrolled_with_) return file;
  file.credential_ = {wanted->fingerprint, random_secret(token_bytes), wanted->code};
  std::error_code fault;  // the folder of a robot's first start need not be there yet, as its spool's
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), fault);
  if (fault) return failure(ErrorCode::unavailable, path.parent_path().string() + ": " + fault.message());
  if (auto written = file.write(); !written) return tl::unexpected(written.error());
  return file;
}

Result<void> CredentialFile::confirmed() {
  if (credential_.code.empty()) return {};
  enrolled_with_ = sha256(credential_.code);
  credential_.code.clear();
  return write();
}

Result<void> CredentialFile::write() const {
  std::string content = std::string(title) + "\nrobot " + robot_ + "\nserver " + to_hex(credential_.fingerprint) +
                        "\ntoken " + to_hex(credential_.token) + "\n";
  if (!credential_.code.empty()) content += "code " + to_hex(credential_.code) + "\n";
  if (!enrolled_with_.empty()) content += "enrolled-with " + to_hex(enrolled_with_) + "\n";
  return write_private_file(path_, content);
}

}  // namespace headframe
