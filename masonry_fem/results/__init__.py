"""What came out: figures by block, the certificate, the summary."""
