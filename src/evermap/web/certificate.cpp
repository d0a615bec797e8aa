// SPDX-FileCopyrightText: 2026 the evermap authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <iomanip>
#include <memory>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>
#include <sstream>
#include <unistd.h>

#include <evermap/web/detail/certificate.hpp>
#include <evermap/web/web_server.hpp>

namespace evermap {
namespace {

template <auto Free>
struct Deleter {
  template <class T>
  void operator()(T* object) const {
    Free(object);
  }
};
using Key = std::unique_ptr<EVP_PKEY, Deleter<EVP_PKEY_free>>;
using X509Certificate = std::unique_ptr<X509, Deleter<X509_free>>;
using X509Extension = std::unique_ptr<X509_EXTENSION, Deleter<X509_EXTENSION_free>>;
using Bio = std::unique_ptr<BIO, Deleter<BIO_free>>;

void check(bool is_done) {
  if (!is_done) throw WebError("no certificate could be made (OpenSSL)");
}

template <class Write>
std::string pem_of(Write&& write) {
  const Bio memory(BIO_new(BIO_s_mem()));
  check(memory != nullptr && write(memory.get()) == 1);
  char* data = nullptr;
  const long size = BIO_get_mem_data(memory.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

}  // namespace

Certificate make_certificate() {
  const Key key(EVP_EC_gen("P-256"));
  const X509Certificate certificate(X509_new());
  check(key != nullptr && certificate != nullptr);
  constexpr int kVersion3 = 2;
  constexpr long kYear = 365L * 24 * 3600;  // [s]
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0 || host[0] == 0) host = {"localhost"};
  X509* x = certificate.get();
  std::uint64_t serial = 0;  // browsers refuse two of one name and number
  check(RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof(serial)) == 1);
  X509_set_version(x, kVersion3);
  ASN1_INTEGER_set_uint64(X509_get_serialNumber(x), serial >> 1);
  X509_gmtime_adj(X509_getm_notBefore(x), -24L * 3600);  // clocks differ
  X509_gmtime_adj(X509_getm_notAfter(x), kYear);
  X509_set_pubkey(x, key.get());
  X509_NAME* name = X509_get_subject_name(x);
  constexpr std::size_t kLongestName = 64;
  const std::string common = std::string(host.data()).substr(0, kLongestName);
  check(X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC,
                                   reinterpret_cast<const unsigned char*>(common.c_str()), -1, -1, 0) == 1);
  X509_set_issuer_name(x, name);
  const std::string names = "DNS:localhost,IP:127.0.0.1,DNS:" + common;
  const X509Extension extension(X509V3_EXT_conf_nid(nullptr, nullptr, NID_subject_alt_name, names.c_str()));
  if (extension != nullptr) X509_add_ext(x, extension.get(), -1);
  check(X509_sign(x, key.get(), EVP_sha256()) != 0);

  Certificate made;
  made.certificate = pem_of([&](BIO* bio) { return PEM_write_bio_X509(bio, x); });
  made.key = pem_of([&](BIO* bio) {
    return PEM_write_bio_PrivateKey(bio, key.get(), nullptr, nullptr, 0, nullptr, nullptr);
  });
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  check(X509_digest(x, EVP_sha256(), digest.data(), &size) == 1);
  std::ostringstream words;
  for (unsigned i = 0; i < size; ++i)
    words << (i > 0 ? ":" : "") << std::uppercase << std::hex << std::setw(2) << std::setfill('0')
          << static_cast<int>(digest[i]);
  made.fingerprint = words.str();
  return made;
}

}  // namespace evermap
