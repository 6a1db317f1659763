#pragma once
// A neural network from an ONNX file. What runs it stays in network.cpp.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace headframe {

/// One image in, some vectors out.
class Network {
 public:
  struct Shape {  // of the input, for one image
    std::size_t channels = 0, rows = 0, columns = 0;
    std::size_t size() const { return channels * rows * columns; }
    bool operator==(const Shape&) const = default;
  };
  struct Output {
    std::string name;
    std::size_t size = 0;  // values for one image
  };

  /// Reads the network and runs it once on zeros. name: what messages call it. bad_input: no ONNX or cut short, not one
  /// image in, or something in it that can not be run here; not_found: this build has no networks (HEADFRAME_NETWORKS).
  static Result<Network> from_bytes(std::string_view onnx, const std::string& name);
  /// The bytes of a file; not_found when it can not be read.
  static Result<std::string> read(const std::filesystem::path& file);

  Network(Network&&) noexcept;
  Network& operator=(Network&&) noexcept;
  ~Network();

  const Shape& input() const { return input_; }
  const std::vector<Output>& outputs() const { return outputs_; }

  /// image: channel by channel, row by row, input().size() values. The values of each output, in the order of
  /// outputs(). bad_input: another size, or a value that is not finite came out. Thread safe, one image at a time; the
  /// runtime may use several threads for it.
  Result<std::vector<std::vector<float>>> run(const std::vector<float>& image) const;

 private:
  struct Runtime;
  Network(std::string name, std::unique_ptr<Runtime> runtime);

  std::string name_;
  Shape input_;
  std::vector<Output> outputs_;
  std::unique_ptr<Runtime> runtime_;
};

/// "2x16x256"
std::string to_string(const Network::Shape& shape);

}  // namespace headframe
