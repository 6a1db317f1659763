#pragma once

#include <filesystem>
#include <string>

#include "common/result.hpp"

namespace headframe {

/// What a robot needs to be let in, and to know the server.
struct RobotCredential {
  std::string fingerprint;  // 32 bytes, of the server's certificate
  std::string token;        // 32 bytes, made here: the server keeps its digest
  std::string code;         // 16 bytes of an enrolment that the server has not confirmed; else empty
};

/// A robot's credential on its disk (mode 0600). Not thread safe.
class CredentialFile {
 public:
  /// `enrolment` is what `headframe robot add` printed; an empty one, or the one that was used here last, takes what is
  /// in the file, and a new one begins a new credential. invalid_argument: no enrolment and no file; bad_input: this is
  /// no enrolment, or no credential is in the file; refused: the file is another robot's, or others can read it.
  static Result<CredentialFile> open(const std::filesystem::path& path, const std::string& robot,
                                     const std::string& enrolment);

  const RobotCredential& credential() const { return credential_; }

  /// The server has let the robot in: the code is done with.
  Result<void> confirmed();

 private:
  Result<void> write() const;

  std::filesystem::path path_;
  std::string robot_;
  RobotCredential credential_;
  std::string enrolled_with_;  // digest of the last code that was confirmed
};

}  // namespace headframe
