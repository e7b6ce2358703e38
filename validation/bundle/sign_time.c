/* SPDX-License-Identifier: Apache-2.0 */
/* Checks time stamps of RFC 3161. The response of a time-stamping authority is in a file next to the envelope. */
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ts.h>

#include <stdlib.h>
#include <string.h>

#include "core/file.h"
#include "validation/bundle/sign_parts.h"

enum { CERTIFICATES_MAX = 1 << 20 };

ost_status sign_authority_open(const char *path, X509_STORE **out, ost_error *err)
{
    char *bytes;
    size_t size;
    int found = 0;
    *out = NULL;
    ost_status status = ost_file_read(path, CERTIFICATES_MAX, &bytes, &size, NULL, err);
    if (status != OST_OK)
        return status;
    BIO *bio = BIO_new_mem_buf(bytes, (int)size);
    X509_STORE *store = X509_STORE_new();
    for (X509 *one; bio && store && (one = PEM_read_bio_X509(bio, NULL, NULL, NULL)); X509_free(one))
        found += X509_STORE_add_cert(store, one) == 1;
    ERR_clear_error();
    BIO_free(bio);
    free(bytes);
    if (!store)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for certificates", path);
    if (!found) {
        X509_STORE_free(store);
        return ost_fail(err, OST_ERR_INPUT, "%s: no certificate in PEM", path);
    }
    *out = store;
    return OST_OK;
}

/* Writes the time that the authority certifies, in the form "2026-11-22T21:45:00Z". */
static void time_of(TS_RESP *response, char time[SIGN_TIME])
{
    TS_TST_INFO *info = TS_RESP_get_tst_info(response);
    const ASN1_GENERALIZEDTIME *made = info ? TS_TST_INFO_get_time(info) : NULL;
    struct tm utc;
    if (!made || ASN1_TIME_to_tm((const ASN1_TIME *)made, &utc) != 1 ||
        strftime(time, SIGN_TIME, "%Y-%m-%dT%H:%M:%SZ", &utc) == 0)
        snprintf(time, SIGN_TIME, "%s", "?");
}

const char *sign_time_check(X509_STORE *authority, const char *response, size_t response_size, const char *bytes,
                            size_t size, char time[SIGN_TIME])
{
    const unsigned char *at = (const unsigned char *)response;
    const char *why = NULL;
    TS_RESP *r = d2i_TS_RESP(NULL, &at, (long)response_size);
    TS_VERIFY_CTX *c = TS_VERIFY_CTX_new();
    BIO *data = BIO_new_mem_buf(bytes, (int)size);
    time[0] = '\0';
    if (!r || at != (const unsigned char *)response + response_size)
        why = "is no response of a time-stamping authority (RFC 3161, DER)";
    else if (!c || !data || X509_STORE_up_ref(authority) != 1)
        why = "cannot be checked: no memory";
    else {
        TS_VERIFY_CTX_set_flags(c, TS_VFY_VERSION | TS_VFY_SIGNATURE | TS_VFY_DATA);
#if OPENSSL_VERSION_NUMBER >= 0x30400000L
        TS_VERIFY_CTX_set0_data(c, data);
        TS_VERIFY_CTX_set0_store(c, authority);
#else
        TS_VERIFY_CTX_set_data(c, data);
        TS_VERIFY_CTX_set_store(c, authority);
#endif
        data = NULL;
        if (TS_RESP_verify_response(c, r) != 1)
            why = "is no time stamp of this envelope that the authority's certificates confirm";
        else
            time_of(r, time);
    }
    ERR_clear_error();
    BIO_free(data);
    TS_VERIFY_CTX_free(c);
    TS_RESP_free(r);
    return why;
}
