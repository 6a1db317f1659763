// The weights are part of the program, taken in by the assembler: a robot needs no file beside it.
#include "common/descriptor/network_family.hpp"

asm(".pushsection .rodata\nheadframe_learned: .incbin \"" HEADFRAME_LEARNED_ONNX
    "\"\nheadframe_learned_end:\n.popsection");
extern "C" const char headframe_learned[], headframe_learned_end[];

namespace headframe {

Result<std::unique_ptr<DescriptorFamily>> make_learned() {
  const auto size = static_cast<std::size_t>(headframe_learned_end - headframe_learned);
  auto network = Network::from_bytes({headframe_learned, size}, "learned");
  if (!network) return tl::unexpected(network.error());
  return NetworkFamily::make({"learned", 1}, std::move(*network), NetworkImage{}, NetworkFamily::QLength::one,
                             "learned");
}

}  // namespace headframe
