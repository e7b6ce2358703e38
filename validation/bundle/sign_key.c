/* SPDX-License-Identifier: Apache-2.0 */
/* Reads signing keys from PEM files: Ed25519 (RFC 8032), and ECDSA over P-256 with SHA-256. */
#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <openssl/core_names.h>
#include <openssl/crypto.h>
#include <openssl/err.h>
#include <openssl/pem.h>

#include "core/file.h"
#include "validation/bundle/sign_parts.h"

enum { KEY_FILE_MAX = 1 << 20, PASSPHRASE_MAX = 1024 };

static bool is_ed25519(const EVP_PKEY *key)
{
    return EVP_PKEY_is_a(key, "ED25519");
}

static bool is_supported(const EVP_PKEY *key)
{
    char group[32] = "";
    if (is_ed25519(key))
        return true;
    return EVP_PKEY_is_a(key, "EC") &&
           EVP_PKEY_get_utf8_string_param(key, OSSL_PKEY_PARAM_GROUP_NAME, group, sizeof group, NULL) == 1 &&
           strcmp(group, "prime256v1") == 0;
}

/* Checks the type of a key and stores it in *out. Takes ownership of pkey even on failure. */
static ost_status take_key(const char *path, EVP_PKEY *pkey, sign_key *out, ost_error *err)
{
    unsigned char *der = NULL;
    ost_digest digest;
    ost_status status = OST_OK;
    if (!is_supported(pkey))
        status = ost_fail(
            err, OST_ERR_INPUT,
            "%s: not an Ed25519 or ECDSA P-256 key (openssl genpkey -algorithm ed25519 makes one)",
            path);
    const int size = status == OST_OK ? i2d_PUBKEY(pkey, &der) : 0;
    if (status == OST_OK)
        status = size > 0 ? ost_digest_bytes(der, (size_t)size, &digest, err)
                          : ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a key", path);
    OPENSSL_free(der);
    if (status == OST_OK) {
        out->key = pkey;
        ost_digest_hex(&digest, out->fingerprint);
    } else
        EVP_PKEY_free(pkey);
    return status;
}

/* --------------------------------------------------------- private keys */

static int give_passphrase(char *to, int size, int writing, void *user)
{
    const char *text = user;
    const size_t length = strcspn(text, "\r\n");
    (void)writing;
    if (length > (size_t)size)
        return -1;
    memcpy(to, text, length);
    return (int)length;
}

/* Reports why no private key could be read from a PEM file. `secret` is the content of the passphrase file, or NULL. */
static ost_status no_private_key(const char *path, bool encrypted, const char *passphrase, const char *secret,
                                 ost_error *err)
{
    if (!encrypted)
        return ost_fail(err, OST_ERR_INPUT, "%s: not a private key in PEM; expected Ed25519 or ECDSA P-256", path);
    if (!passphrase)
        return ost_fail(err, OST_ERR_INPUT, "%s: is encrypted, and the passphrase does not decrypt it", path);
    if (strcspn(secret, "\r\n") == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: the first line is empty; expected the passphrase of %s", passphrase,
                        path);
    return ost_fail(err, OST_ERR_INPUT, "%s: is encrypted, and the passphrase in %s does not decrypt it", path,
                    passphrase);
}

ost_status sign_key_open(const char *path, const char *passphrase, sign_key **out, ost_error *err)
{
    char *bytes = NULL, *secret = NULL;
    size_t size = 0, secret_size = 0;
    *out = NULL;
    ost_status status = ost_file_read(path, KEY_FILE_MAX, &bytes, &size, NULL, err);
    if (status == OST_OK && passphrase)
        status = ost_file_read(passphrase, PASSPHRASE_MAX, &secret, &secret_size, NULL, err);
    const bool encrypted = status == OST_OK && size >= 9 && strstr(bytes, "ENCRYPTED");
    /* Without this check, OpenSSL would prompt on standard error and read the passphrase from standard input. */
    if (encrypted && !passphrase && !isatty(STDIN_FILENO))
        status = ost_fail(err, OST_ERR_INPUT, "%s: is encrypted; pass --passphrase-file FILE", path);
    BIO *bio = status == OST_OK ? BIO_new_mem_buf(bytes, (int)size) : NULL;
    if (status == OST_OK) {
        EVP_PKEY *pkey = bio ? PEM_read_bio_PrivateKey(bio, NULL, secret ? give_passphrase : NULL, secret) : NULL;
        ERR_clear_error();
        sign_key *key = pkey ? calloc(1, sizeof *key) : NULL;
        if (!pkey)
            status = no_private_key(path, encrypted, passphrase, secret, err);
        else if (!key) {
            EVP_PKEY_free(pkey);
            status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a key", path);
        } else if ((status = take_key(path, pkey, key, err)) != OST_OK)
            free(key);
        else
            *out = key;
    }
    BIO_free(bio);
    if (bytes)
        OPENSSL_cleanse(bytes, size);
    if (secret)
        OPENSSL_cleanse(secret, secret_size);
    free(bytes);
    free(secret);
    return status;
}

void sign_key_free(sign_key *key)
{
    if (key)
        EVP_PKEY_free(key->key);
    free(key);
}

/* ---------------------------------------------------------- public keys */

static bool is_trusted(const sign_trust *t, const char *fingerprint)
{
    for (int i = 0; i < t->count; i++)
        if (strcmp(t->keys[i].fingerprint, fingerprint) == 0)
            return true;
    return false;
}

/* Adds every PUBLIC KEY block of a PEM file to the trusted keys. */
static ost_status trust_file(const char *path, sign_trust *t, ost_error *err)
{
    char *bytes;
    size_t size;
    int found = 0;
    ost_status status = ost_file_read(path, KEY_FILE_MAX, &bytes, &size, NULL, err);
    if (status != OST_OK)
        return status;
    BIO *bio = BIO_new_mem_buf(bytes, (int)size);
    for (EVP_PKEY *pkey; status == OST_OK && bio && (pkey = PEM_read_bio_PUBKEY(bio, NULL, NULL, NULL)); found++) {
        sign_key key = {.key = NULL};
        if (t->count == SIGN_KEYS_MAX) {
            EVP_PKEY_free(pkey);
            status = ost_fail(err, OST_ERR_INPUT, "%s: more than %d trusted keys", path, SIGN_KEYS_MAX);
        } else if ((status = take_key(path, pkey, &key, err)) == OST_OK) {
            if (is_trusted(t, key.fingerprint))
                EVP_PKEY_free(key.key);
            else
                t->keys[t->count++] = key;
        }
    }
    ERR_clear_error();
    BIO_free(bio);
    const bool certificate = strstr(bytes, "-----BEGIN CERTIFICATE-----") != NULL;
    free(bytes);
    if (status == OST_OK && !found)
        status = ost_fail(err, OST_ERR_INPUT,
                          certificate ? "%s: is a certificate, whose dates and purpose are not judged here; a public "
                                        "key is expected (openssl x509 -in CERT -pubkey -noout writes it)"
                                      : "%s: no public key in PEM (openssl pkey -in KEY -pubout writes one)",
                          path);
    return status;
}

static bool ends_with(const char *text, const char *end)
{
    const size_t a = strlen(text), b = strlen(end);
    return a >= b && strcmp(text + a - b, end) == 0;
}

/* Adds the keys in every *.pem file of a folder to the trusted keys. */
static ost_status trust_folder(const char *path, sign_trust *t, ost_error *err)
{
    const int before = t->count;
    DIR *dir = opendir(path);
    ost_status status = dir ? OST_OK : ost_fail(err, OST_ERR_IO, "%s: %s", path, strerror(errno));
    for (struct dirent *e; status == OST_OK && (status = bundle_next_entry(dir, path, &e, err)) == OST_OK && e;) {
        char name[BUNDLE_PATH];
        if (!ends_with(e->d_name, ".pem"))
            continue;
        status = snprintf(name, sizeof name, "%s/%s", path, e->d_name) < (int)sizeof name
                     ? trust_file(name, t, err)
                     : ost_fail(err, OST_ERR_INPUT, "%.200s: a name in it is too long", path);
    }
    if (dir)
        closedir(dir);
    return status == OST_OK && t->count == before
               ? ost_fail(err, OST_ERR_INPUT, "%s: no public key (*.pem) in this folder", path)
               : status;
}

ost_status sign_trust_open(const char *const paths[], int count, const char *authority, sign_trust **out,
                           ost_error *err)
{
    sign_trust *t = calloc(1, sizeof *t);
    ost_status status = t ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for trusted keys");
    *out = NULL;
    for (int i = 0; i < count && status == OST_OK; i++) {
        struct stat info;
        status = stat(paths[i], &info) == 0 && S_ISDIR(info.st_mode) ? trust_folder(paths[i], t, err)
                                                                     : trust_file(paths[i], t, err);
    }
    if (status == OST_OK && authority)
        status = sign_authority_open(authority, &t->authority, err);
    if (status == OST_OK)
        *out = t;
    else
        sign_trust_free(t);
    return status;
}

void sign_trust_free(sign_trust *trust)
{
    if (!trust)
        return;
    for (int i = 0; i < trust->count; i++)
        EVP_PKEY_free(trust->keys[i].key);
    X509_STORE_free(trust->authority);
    free(trust);
}

/* ----------------------------------------------------------- signatures */

/* Returns the hash function for a key. Returns NULL for Ed25519, whose signature scheme includes a hash function. */
static const EVP_MD *digest_of(const sign_key *key)
{
    return is_ed25519(key->key) ? NULL : EVP_sha256();
}

ost_status sign_make(const sign_key *key, const void *bytes, size_t size, unsigned char **signature,
                     size_t *signature_size, ost_error *err)
{
    EVP_MD_CTX *c = EVP_MD_CTX_new();
    bool made = c && EVP_DigestSignInit(c, NULL, digest_of(key), NULL, key->key) == 1 &&
                EVP_DigestSign(c, NULL, signature_size, bytes, size) == 1;
    *signature = made ? malloc(*signature_size) : NULL;
    made = *signature && EVP_DigestSign(c, *signature, signature_size, bytes, size) == 1;
    EVP_MD_CTX_free(c);
    ERR_clear_error();
    if (made)
        return OST_OK;
    free(*signature);
    *signature = NULL;
    return ost_fail(err, OST_ERR_IO, "libcrypto made no signature with key %s", key->fingerprint);
}

bool sign_holds(const sign_key *key, const void *bytes, size_t size, const unsigned char *signature,
                size_t signature_size)
{
    EVP_MD_CTX *c = EVP_MD_CTX_new();
    const bool holds = c && EVP_DigestVerifyInit(c, NULL, digest_of(key), NULL, key->key) == 1 &&
                       EVP_DigestVerify(c, signature, signature_size, bytes, size) == 1;
    EVP_MD_CTX_free(c);
    ERR_clear_error();
    return holds;
}
