#pragma once
// Compresses bits with learned probabilities: a binary range coder with carry.

#include <cstdint>
#include <string>
#include <string_view>

namespace headframe {

/// The probability that a bit is 0, in 1/65536, learned from earlier bits: the mean of a fast and a slow estimate, both
/// of which adapt faster at first.
class AdaptiveBit {
 public:
  std::uint32_t zero() const {
    constexpr std::uint32_t least = 64;  // never certain
    const std::uint32_t p = (std::uint32_t{quick_} + slow_) / 2;
    return p < least ? least : p > 65536 - least ? 65536 - least : p;
  }
  void learn(bool bit) {
    if (seen_ < slow_shift) ++seen_;
    quick_ = moved(quick_, bit, seen_ < quick_shift ? seen_ : quick_shift);
    slow_ = moved(slow_, bit, seen_);
  }

 private:
  static constexpr std::uint8_t quick_shift = 4, slow_shift = 7;
  static std::uint16_t moved(std::uint16_t p, bool bit, int shift) {
    return static_cast<std::uint16_t>(bit ? p - (p >> shift) : p + ((65535 - p) >> shift));
  }
  std::uint16_t quick_ = 32768, slow_ = 32768;
  std::uint16_t seen_ = 0;  // not a byte: a store to one may change anything, as far as the compiler knows
};

class RangeEncoder {
 public:
  void put(AdaptiveBit& model, bool bit) {
    const std::uint32_t bound = (range_ >> 16) * model.zero();
    if (bit) {
      low_ += bound;
      range_ -= bound;
    } else {
      range_ = bound;
    }
    model.learn(bit);
    normalise();
  }

  /// The lowest `count` bits of a number, 0 and 1 being equally likely.
  void put_plain(std::uint64_t bits, int count) {
    while (count-- > 0) {
      range_ >>= 1;
      if ((bits >> count & 1U) != 0) low_ += range_;
      normalise();
    }
  }

  /// Nothing may be put after this.
  std::string finish() {
    for (int i = 0; i < 5; ++i) shift();
    return std::move(out_);
  }

 private:
  void normalise() {
    for (; range_ < 1U << 24; range_ <<= 8) shift();
  }
  /// Holds back a byte, and counts 0xff bytes after it, until it is known whether a carry occurs.
  void shift() {
    if (low_ < 0xff000000ULL || low_ > 0xffffffffULL) {
      const auto carry = static_cast<std::uint8_t>(low_ >> 32);
      if (held_) out_.push_back(static_cast<char>(byte_ + carry));
      for (; ones_ > 0; --ones_) out_.push_back(static_cast<char>(0xff + carry));
      byte_ = static_cast<std::uint8_t>(low_ >> 24);
      held_ = true;
    } else {
      ++ones_;
    }
    low_ = low_ << 8 & 0xffffffffULL;
  }

  std::string out_;
  std::uint64_t low_ = 0, ones_ = 0;
  std::uint32_t range_ = 0xffffffffU;
  std::uint8_t byte_ = 0;
  bool held_ = false;
};

/// Accepts any bytes: if they are not an encoder's, some bits are returned, and finally done() returns false.
class RangeDecoder {
 public:
  explicit RangeDecoder(std::string_view bytes) : bytes_(bytes) {
    for (int i = 0; i < 4; ++i) take();
  }

  bool get(AdaptiveBit& model) {
    const std::uint32_t bound = (range_ >> 16) * model.zero();
    const bool bit = code_ >= bound;
    if (bit) {
      code_ -= bound;
      range_ -= bound;
    } else {
      range_ = bound;
    }
    model.learn(bit);
    normalise();
    return bit;
  }

  std::uint64_t get_plain(int count) {
    std::uint64_t bits = 0;
    while (count-- > 0) {
      range_ >>= 1;
      const std::uint32_t bit = code_ >= range_ ? 1 : 0;
      code_ -= range_ & (0U - bit);  // no branch, which would be foreseen half the time
      bits = bits << 1 | bit;
      normalise();
    }
    return bits;
  }

  /// Whether more was read than there is.
  bool overrun() const { return missing_ > 0; }
  /// Whether exactly all bytes were read.
  bool done() const { return next_ == bytes_.size() && missing_ == 0; }

 private:
  void normalise() {
    for (; range_ < 1U << 24; range_ <<= 8) take();
  }
  void take() {
    code_ <<= 8;
    if (next_ < bytes_.size())
      code_ |= static_cast<std::uint8_t>(bytes_[next_++]);
    else
      ++missing_;
  }

  std::string_view bytes_;
  std::size_t next_ = 0, missing_ = 0;
  std::uint32_t range_ = 0xffffffffU, code_ = 0;
};

}  // namespace headframe
