include $(BOARD_DIR)/../common.mk
