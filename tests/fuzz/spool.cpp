// What a spool finds on its disk: any bytes, or whole records of any kind and content.
#include <google/protobuf/stubs/logging.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "client/spool/spool.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace headframe::fuzz {
namespace {

namespace fs = std::filesystem;

const fs::path& folder() {
  static const fs::path path = [] {
    const fs::path memory = "/dev/shm";
    const fs::path base = fs::is_directory(memory) ? memory : fs::temp_directory_path();
    auto made = base / ("headframe-fuzz-" + std::to_string(::getpid()));
    fs::create_directories(made / "clouds");
    std::atexit([] { fs::remove_all(folder()); });
    return made;
  }();
  return path;
}

std::string u32(std::uint32_t v) {
  std::string out;
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<char>(v >> 8 * i));
  return out;
}

/// Each piece is a record: its first byte picks the type.
std::string records(std::string_view bytes) {
  constexpr std::string_view types = "irwkKaAcdDx";
  std::string log;
  for (auto piece : pieces(bytes)) {
    const char type = types[take_byte(piece) % types.size()];
    if (piece.empty()) continue;
    log.append(u32(static_cast<std::uint32_t>(piece.size()))).append(u32(crc32c(piece, crc32c({&type, 1}))));
    log.push_back(type);
    log.append(piece);
  }
  return log;
}

}  // namespace
}  // namespace headframe::fuzz

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  google::protobuf::SetLogHandler(nullptr);  // as the server does
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace headframe;
  auto bytes = fuzz::text(data, size);
  const bool raw = fuzz::take_byte(bytes) % 4 == 0;
  std::ofstream(fuzz::folder() / "session.log", std::ios::binary | std::ios::trunc)
      << (raw ? std::string(bytes) : fuzz::records(bytes));
  const Hello hello{{"ant", "s1"}, {"os1", 32, 22, 22, 120}, {{"f", 1}, 1, 0}, CloudPolicy::all, "fuzz", 7};
  auto spool = Spool::open({fuzz::folder(), 1 << 20, false}, hello);
  if (!spool) return 0;
  for (std::uint64_t s = 1; s <= spool->last_sequence(); ++s) (void)spool->keyframe(s);
  Keyframe next;
  next.sequence = spool->last_sequence() + 1;
  next.descriptor.q = {1};
  fuzz::require(spool->append(next, "").has_value());
  fuzz::require(spool->keyframe(next.sequence).has_value());
  return 0;
}
