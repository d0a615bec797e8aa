// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <limits>

#include "files/file_fixture.hpp"
#include <evermap/files/detail/record_layout.hpp>

namespace evermap {
namespace {

template <typename T>
void expect_decoded(Scalar type, T value) {
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    const std::string bytes = std::string(1, '?').append(bytes_of<T>({value}, order));  // not aligned
    EXPECT_EQ(decode(bytes.data() + 1, type, order), static_cast<double>(value));
  }
  EXPECT_EQ(size_of(type), sizeof(T));
}

TEST(Decode, EveryTypeInBothOrders) {
  expect_decoded<std::int8_t>(Scalar::kInt8, -100);
  expect_decoded<std::uint8_t>(Scalar::kUint8, 200);
  expect_decoded<std::int16_t>(Scalar::kInt16, -30000);
  expect_decoded<std::uint16_t>(Scalar::kUint16, 60000);
  expect_decoded<std::int32_t>(Scalar::kInt32, std::numeric_limits<std::int32_t>::min());
  expect_decoded<std::uint32_t>(Scalar::kUint32, 4'000'000'001U);
  expect_decoded<std::int64_t>(Scalar::kInt64, -(std::int64_t{1} << 52) - 1);
  expect_decoded<std::uint64_t>(Scalar::kUint64, std::uint64_t{1} << 63);
  expect_decoded<float>(Scalar::kFloat32, -1.1F);
  expect_decoded<double>(Scalar::kFloat64, 1e300);
}

TEST(RecordLayout, FieldsFollowEachOther) {
  RecordLayout layout;
  ASSERT_TRUE(layout.append("a", Scalar::kUint16, 3));
  ASSERT_TRUE(layout.append("b", Scalar::kFloat64, 1));
  EXPECT_EQ(layout.fields()[1].offset, 6U);
  EXPECT_EQ(layout.fields()[1].index, 3U);
  EXPECT_EQ(layout.stride(), 14U);
  EXPECT_EQ(layout.value_count(), 4U);
}

TEST(RecordLayout, RefusesWhatWouldOverflow) {
  RecordLayout layout;
  ASSERT_TRUE(layout.append("a", Scalar::kUint8, RecordLayout::kMaxStride - 8));
  EXPECT_FALSE(layout.append("b", Scalar::kFloat64, 2));
  EXPECT_FALSE(layout.append("b", Scalar::kFloat64, std::numeric_limits<std::size_t>::max()));
  EXPECT_TRUE(layout.append("b", Scalar::kFloat64, 1));
  EXPECT_EQ(layout.stride(), RecordLayout::kMaxStride);
}

}  // namespace
}  // namespace evermap
