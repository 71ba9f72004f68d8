int tendril_test_absent() { return 1; }
